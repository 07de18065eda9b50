"""``python -m ifs_cad.cli`` is the command line too."""

from ifs_cad.cli import main

if __name__ == "__main__":
    main()
