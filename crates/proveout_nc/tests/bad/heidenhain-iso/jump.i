; nc-jump-target
%BAD G71 *
N10 T1 G17 S100 *
N20 D09 P01 +1 P02 +1 P03 7 *
