O2 (IF behind WHILE .. DO of its block: at every pass, behind the words before it)
G21 G90 G54 G0 X0. Y0.
#1=0
#2=0
WHILE [#1 LT 4] DO1 #1=#1+1 IF [#1 EQ 3] GOTO 20
G0 X[#1*10.]
END1
N20 G0 Y#1
WHILE [#2 LT 1] DO2 IF [#2 EQ 0] THEN #1=5
#2=#2+1
END2
G0 X#1
M30
