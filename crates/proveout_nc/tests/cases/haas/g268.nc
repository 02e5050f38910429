(G268: a plane about X, the rotary axes turned by G253, and back)
G21 G90 G17 G40 G80 G54
T1 M6
S1000 M3
G0 X0. Y0. Z50. B0 C0
G268 X10. Y0 Z0 I30. J0 K0 Q321
G253
G0 X0. Y0. Z5.
G1 X1. F100.
G269
M30
