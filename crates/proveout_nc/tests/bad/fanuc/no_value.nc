(nc-missing-value)
G0 X
