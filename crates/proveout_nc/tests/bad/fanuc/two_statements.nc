(nc-conflicting-words)
O1
G21 G90 G54
G0 X0. Y0. Z0.
#1=0
WHILE [ #1 LT 3 ] DO1 #1= #1 + 1 IF [ #1 LT 2 ] THEN #1= 2 X5.
G0 X#1
END1
M30
