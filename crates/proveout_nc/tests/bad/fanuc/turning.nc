(nc-unsupported-word)
G21 G0 X50. Z2.
G71 U2. R1.
M30
