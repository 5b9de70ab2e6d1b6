"""Text in: case files (TOML) to models and settings, and the cases that are shipped."""
