(nc-no-feed)
G0 X0
G93 G1 X1. F2.
X2.
