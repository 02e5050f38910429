; nc-unsupported-word
%BAD G71 *
N10 T1 G17 S100 *
N20 G83 P01 2 P02 -10 P03 5 P04 0 P05 100 *
