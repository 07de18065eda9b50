"""What draws the pictures of the documentation; `make_pictures.py` runs it."""
