0 BEGIN PGM INCH INCH
; Lengths in inch, feed in tenths of an inch a minute: F50 is 5 inch/min = 127 mm/min.
1 TOOL CALL "MILL 6" Z S500
2 L X+1 Y+0.5 Z+0.1 R0 FMAX
3 L X+2 F50
4 CC X+2 Y+1
5 C X+2 Y+1.5 DR+
; From (2, 0.5) half a turn about (2, 1): radius 12.7 mm.
6 M2
7 END PGM INCH INCH
