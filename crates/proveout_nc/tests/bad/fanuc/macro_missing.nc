(nc-missing-value)
G65 A1.
