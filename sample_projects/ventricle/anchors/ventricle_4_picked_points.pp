<!DOCTYPE PickedPoints>
<PickedPoints>
    <point x="-0.11291" y="-38.34449" z="-20.37719" active="1" name="apex"/>
    <point x="22.62825" y="-14.63534" z="-9.26739" active="1" name="front"/>
    <point x="-10.94769" y="-6.67506" z="-25.58839" active="1" name="left"/>
    <point x="-10.20578" y="-24.80374" z="11.58092" active="1" name="right"/>
</PickedPoints>
