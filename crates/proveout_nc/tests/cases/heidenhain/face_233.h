0 BEGIN PGM FACE_233 MM
; the tests give Q108, the radius of the tool, as 6
1 TOOL CALL 1 Z S1000 F500
2 L X+10 Y+20 Z+50 R0 FMAX M3
; meanders along X that end outside, in two depths: passes at Y 24 and 32, from X 2 to 68, depths 0.75 and -0.5, then -1 finished
3 CYCL DEF 233 FACE MILLING ~
    Q215=+0 ~
    Q389=+0 ~
    Q350=+1 ~
    Q218=+50 ~
    Q219=+16 ~
    Q227=+2 ~
    Q386=-1 ~
    Q369=+0.5 ~
    Q202=+1.25 ~
    Q370=+1.5 ~
    Q207=+500 ~
    Q385=+300 ~
    Q253=+750 ~
    Q357=+2 ~
    Q200=+2 ~
    Q204=+20 ~
    Q347=+0 ~
    Q348=+0 ~
    Q349=+0 ~
    Q220=+0 ~
    Q368=+0 ~
    Q338=+0
4 CYCL CALL
; line by line along Y to the edge, the tool in the middle of the surface
5 CYCL DEF 233 FACE MILLING ~
    Q215=+1 ~
    Q389=+3 ~
    Q350=+2 ~
    Q218=+16 ~
    Q219=+50 ~
    Q227=+2 ~
    Q386=+1 ~
    Q369=+0 ~
    Q202=+2 ~
    Q370=+1.5 ~
    Q207=+500 ~
    Q385=+300 ~
    Q253=+750 ~
    Q357=+2 ~
    Q200=+2 ~
    Q204=+20 ~
    Q367=+0
6 L X+100 Y+100 FMAX M99
; to the left and down from the tool, in meanders that turn at the edge
7 CYCL DEF 233 FACE MILLING ~
    Q215=+1 Q389=+1 Q350=+1 Q218=-50 Q219=-16 Q227=+2 Q386=+1 Q369=+0 Q202=+2 Q370=+1 Q207=+500 Q385=+300 Q253=+750 Q357=+2 Q200=+2 Q204=+20
8 L X+0 Y+0 FMAX M99
9 M30
10 END PGM FACE_233 MM
