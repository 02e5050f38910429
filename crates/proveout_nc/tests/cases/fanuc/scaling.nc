O0051 (G51: the same contour as it is, half as large about the origin, and by axis)
G21 G90 G17 G40 G50 G54
T1 M6
S2000 M3
G0 X0. Y0.
G43 H1 Z50.
G51 X0. Y0. Z0. P500
M98 P1000
G50
(X twice, Y mirrored about Y10, Z as it is: lines alone)
G51 Y10. I2000 J-1000 K1000
G0 X10. Y10. Z2.
G1 X20. Y30. F100.
G50
(a mirror of equal scales turns arcs round)
G51 X0. Y0. Z0. I-1.5 J1.5 K1.5
M98 P1000
G50
G0 Z50.
M30
O1000
G0 X10. Y10.
G1 Z-1. F100.
X20.
G2 X30. Y20. R10.
G1 Y30.
G0 Z2.
M99
