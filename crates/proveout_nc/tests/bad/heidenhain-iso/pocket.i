; nc-arguments
%BAD G71 *
N10 T1 G17 S100 *
N20 G251 Q215=0 *
