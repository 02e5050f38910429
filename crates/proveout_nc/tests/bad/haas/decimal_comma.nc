(nc-syntax)
G21 G0 X10,5 Y10.
M30
