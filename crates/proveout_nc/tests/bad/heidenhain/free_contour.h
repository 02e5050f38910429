; nc-unsupported-word
BEGIN PGM BAD MM
TOOL CALL 1 Z S100
FL X+10 Y+10
