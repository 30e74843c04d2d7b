"""World files as TOML, the format of the rooms that ship: tables, formulas, parameters, notes."""
