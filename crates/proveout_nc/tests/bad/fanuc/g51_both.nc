(nc-conflicting-words)
G51 X0 Y0 Z0 P2000 I1000
