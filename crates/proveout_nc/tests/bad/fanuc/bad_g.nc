(nc-bad-value)
G1.25 X1.
