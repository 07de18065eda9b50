"""TOML files that people write: read with errors that name the line."""
