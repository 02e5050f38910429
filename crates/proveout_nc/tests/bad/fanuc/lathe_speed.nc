(nc-unsupported-word)
O1
G21 G90 G54
G50 S2000
G96 S180 M3
M30
