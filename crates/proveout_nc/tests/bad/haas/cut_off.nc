(nc-no-end)
%
O00001
G21 G0 X0. Y0.
G1 X5. F100.
