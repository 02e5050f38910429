; nc-conflicting-words
%BAD G71 *
N10 T1 G17 S100 *
N20 G00 X+0 Y+0 Z+0 *
N30 G01 R+5 F100 *
