(nc-conflicting-words)
G0 G1 X1.
