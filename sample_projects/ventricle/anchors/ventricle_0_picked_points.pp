<!DOCTYPE PickedPoints>
<PickedPoints>
    <point x="-1.11078" y="-39.56741" z="-19.75828" active="1" name="apex"/>
    <point x="25.10699" y="-15.77321" z="-8.67639" active="1" name="front"/>
    <point x="-11.99752" y="-6.57084" z="-27.54404" active="1" name="left"/>
    <point x="-11.20938" y="-25.82911" z="11.94125" active="1" name="right"/>
</PickedPoints>
