; nc-unsupported-word
%BAD G71 *
N10 T1 G17 S100 *
N20 G26 R5 *
