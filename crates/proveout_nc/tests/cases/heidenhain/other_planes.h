0 BEGIN PGM PLANES MM
1 TOOL CALL 1 Z S1000 F500
2 L X+12 Y+0 Z+5 R0 FMAX
3 CC X+4 Z+5
; the plane Z X: angles count from Z, so that +X is 90 degrees
4 CP IPA+90 DR+
; about +Y from (X 12, Z 5) down to (X 4, Z -3)
5 L X+0 Z-3
6 CC X+0 Z+5
7 CP IPA+90 DR+ F200
; up to (X -8, Z 5)
8 CC Y+10 Z+5
; the plane Y Z: angles count from Y
9 CP IPA-90 DR-
; about -X from (Y 0, Z 5), which is 180 degrees, to (Y 10, Z 15)
10 C Y+20 Z+5 DR-
; another quarter
11 CC X+0 Y+20
; the working plane again
12 CP IPA+180 DR+ IZ-2
; half a turn of a helix to (X 8, Y 20, Z 3)
13 L X+25 Y+45 Z+25 F200
14 CC X+25 Z+35
15 LP PR+10 PA+90
; 90 degrees from Z is +X: (X 35, Z 35)
16 C X+25 Z+45 DR-
; from +X to +Z is against the right hand about +Y
17 CP IPA+180 IY-4 DR+
; half a helix about +Y: (X 25, Y 41, Z 25)
18 M30
19 END PGM PLANES MM
