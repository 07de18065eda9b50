"""Programs for a sheet: tool paths, posts, and the reading and verifying of what was written."""
