0 BEGIN PGM MILLING MM
; the tests give Q108, the radius of the tool, as 6
1 TOOL CALL 1 Z S1000 F500
2 L X+0 Y+0 R0 FMAX M3
3 L Z+50 FMAX
4 CYCL DEF 251 RECTANGULAR POCKET ~
    Q215=+0      ;MACHINING OPERATION ~
    Q218=+40     ;FIRST SIDE LENGTH ~
    Q219=+30     ;2ND SIDE LENGTH ~
    Q220=+8      ;CORNER RADIUS ~
    Q368=+1      ;ALLOWANCE FOR SIDE ~
    Q224=+0      ;ANGLE OF ROTATION ~
    Q367=+1      ;POCKET POSITION ~
    Q207=+400    ;FEED RATE FOR MILLING ~
    Q351=+1      ;CLIMB OR UP-CUT ~
    Q201=-6      ;DEPTH ~
    Q202=+4      ;PLUNGING DEPTH ~
    Q369=+0.5    ;ALLOWANCE FOR FLOOR ~
    Q206=+100    ;FEED RATE FOR PLNGNG ~
    Q338=+0      ;INFEED FOR FINISHING ~
    Q200=+2      ;SET-UP CLEARANCE ~
    Q203=+0      ;SURFACE COORDINATE ~
    Q204=+20     ;2ND SET-UP CLEARANCE ~
    Q370=+1      ;TOOL PATH OVERLAP ~
    Q366=+0      ;PLUNGE ~
    Q385=+300    ;FEED RATE FOR FINISHING
; the tool stands at the lower left corner: middle at (20, 15); rings of half sides 13 x 8 and 7 x 2 with allowance
5 CYCL CALL
6 CYCL DEF 252 CIRCULAR POCKET ~
    Q215=+1 ~
    Q223=+30 ~
    Q368=+0 ~
    Q207=+400 ~
    Q351=-1 ~
    Q201=-3 ~
    Q202=+3 ~
    Q369=+0 ~
    Q206=+100 ~
    Q338=+0 ~
    Q200=+2 ~
    Q203=+0 ~
    Q204=+20 ~
    Q370=+1 ~
    Q366=+1
; circles of radius 3 and 9, clockwise; the helix of radius 6 needs 5 / (2 pi 6 tan 3) = 2.5 turns for 5 mm at 3 degrees: 3
7 L X+100 Y+0 FMAX M99
8 CYCL DEF 253 SLOT MILLING ~
    Q215=+1 ~
    Q218=+40 ~
    Q219=+12 ~
    Q368=+0 ~
    Q374=+90 ~
    Q367=+2 ~
    Q207=+400 ~
    Q351=+1 ~
    Q201=-2 ~
    Q202=+2 ~
    Q369=+0 ~
    Q206=+100 ~
    Q338=+0 ~
    Q200=+2 ~
    Q203=+0 ~
    Q204=+20 ~
    Q366=+1
; as wide as the tool: its spine from (100, 50) to (100, 78), reached to and fro
9 L X+100 Y+50 FMAX M99
10 CYCL DEF 254 CIRCULAR SLOT ~
    Q215=+1 ~
    Q219=+14 ~
    Q368=+0 ~
    Q375=+60 ~
    Q367=+0 ~
    Q216=+200 ~
    Q217=+0 ~
    Q376=+0 ~
    Q248=+90 ~
    Q378=+180 ~
    Q377=+2 ~
    Q207=+400 ~
    Q351=+1 ~
    Q201=-2 ~
    Q202=+2 ~
    Q369=+0 ~
    Q206=+100 ~
    Q338=+0 ~
    Q200=+2 ~
    Q203=+0 ~
    Q204=+20 ~
    Q366=+0
; two slots about (200, 0), the second turned by 180 degrees
11 CYCL CALL
12 CYCL DEF 256 RECTANGULAR STUD ~
    Q218=+40 ~
    Q424=+60 ~
    Q219=+20 ~
    Q425=+40 ~
    Q220=+4 ~
    Q368=+0 ~
    Q224=+0 ~
    Q367=+0 ~
    Q207=+400 ~
    Q351=+1 ~
    Q201=-2 ~
    Q202=+2 ~
    Q206=+100 ~
    Q200=+2 ~
    Q203=+0 ~
    Q204=+20 ~
    Q370=+1 ~
    Q437=+0
; 10 mm around the stud in two revolutions, clockwise; the tool plunges at 30 + 2 + 6 = 38 mm beside the middle
13 L X+0 Y+100 FMAX M99
14 CYCL DEF 257 CIRCULAR STUD ~
    Q223=+20 ~
    Q222=+30 ~
    Q368=+0 ~
    Q207=+400 ~
    Q351=+1 ~
    Q201=-2 ~
    Q202=+2 ~
    Q206=+100 ~
    Q200=+2 ~
    Q203=+0 ~
    Q204=+20 ~
    Q370=+1 ~
    Q376=+90
15 L X+100 Y+150 FMAX M99
16 CYCL DEF 208 BORE MILLING ~
    Q200=+2 ~
    Q201=-10 ~
    Q206=+200 ~
    Q334=+3 ~
    Q203=+0 ~
    Q204=+20 ~
    Q335=+20 ~
    Q342=+0 ~
    Q351=+1
; radius 4, four turns for 12 mm
17 L X+200 Y+100 FMAX M99
18 CYCL DEF 262 THREAD MILLING ~
    Q335=+20 ~
    Q239=+2 ~
    Q201=-10 ~
    Q355=+1 ~
    Q253=+750 ~
    Q351=+1 ~
    Q200=+2 ~
    Q203=+0 ~
    Q204=+20 ~
    Q207=+300
; five turns upwards from Z -10 to 0, led in from Z -11 to -10
19 CYCL CALL
20 CYCL DEF 232 FACE MILLING ~
    Q389=+0 ~
    Q225=+0 ~
    Q226=+0 ~
    Q227=+2 ~
    Q386=+0 ~
    Q218=+50 ~
    Q219=+20 ~
    Q202=+1.5 ~
    Q369=+0.5 ~
    Q370=+1.8 ~
    Q207=+500 ~
    Q385=+300 ~
    Q253=+750 ~
    Q200=+2 ~
    Q357=+2 ~
    Q204=+10
; two passes at Y 5 and 15 (12 mm apart at most, the overlap counts as 1.7), from X -8 to 58; depth 0.5 in one infeed, then to 0
21 CYCL CALL
22 M30
23 END PGM MILLING MM
