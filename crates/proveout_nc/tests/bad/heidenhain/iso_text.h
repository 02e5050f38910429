; nc-unknown-word
O1000
G21 G90 G54
G0 X0. Y0.
M30
