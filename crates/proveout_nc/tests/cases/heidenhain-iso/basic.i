%BASIC G71 *
N10 G30 G17 X+0 Y+0 Z-20 *
N20 G31 G90 X+100 Y+100 Z+0 *
N30 T1 G17 S2000 F300 *
N40 G00 G40 G90 Z+100 M3 *
N50 X-20 Y-20 *
; G00 is modal
N60 G01 Z-5 F200 M8 *
N70 G01 G41 X+0 Y+0 *
N80 X+50 *
N90 G25 R10 *
; feet (40, 0) and (50, 10)
N100 Y+40 *
N110 G24 R5 *
N120 X+20 *
N130 I+20 J+20 *
; pole
N140 G03 X+0 Y+20 *
; quarter from (20, 40) about (20, 20)
N150 G02 X+20 Y+0 R+20 *
; about (20, 20) clockwise it would be three quarters; R+ takes at most half a turn: about (0, 0)
N160 G05 X+40 Y+0 R+10 *
; clockwise as before: half a turn about (30, 0)
N170 G06 X+60 Y+10 *
N180 G40 G10 R+30 H+90 *
; rapid polar: (20, 50)
N190 G11 G91 R-10 H-90 *
; radius 20 at 0 degrees: (40, 20)
N200 G13 G91 H+720 Z-4 *
; two turns, Z from -5 to -9
N210 G90 G15 H+180 *
; half a turn counter-clockwise to (0, 20)
N220 G29 *
N230 G91 G01 X+5 *
N240 G90 M5 M9 *
N250 M30 *
N99999999 %BASIC G71 *
