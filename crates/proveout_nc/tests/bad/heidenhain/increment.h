; nc-position-unknown
BEGIN PGM BAD MM
TOOL CALL 1 Z S100
L IX+1 FMAX
