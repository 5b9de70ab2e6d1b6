"""Read case files (TOML): quantities with units, tables, sizes, the JSON Schema, and the cases that are shipped."""
