<!DOCTYPE PickedPoints>
<PickedPoints>
    <point x="-1.49547" y="-34.33659" z="-17.02457" active="1" name="apex"/>
    <point x="18.20120" y="-13.74392" z="-7.37401" active="1" name="front"/>
    <point x="-8.78290" y="-6.90295" z="-21.40008" active="1" name="left"/>
    <point x="-8.14905" y="-22.39093" z="10.35500" active="1" name="right"/>
</PickedPoints>
