<!DOCTYPE PickedPoints>
<PickedPoints>
    <point x="-1.78046" y="-36.01312" z="-17.47791" active="1" name="apex"/>
    <point x="19.91114" y="-14.08167" z="-7.21420" active="1" name="front"/>
    <point x="-9.07785" y="-7.01289" z="-21.70735" active="1" name="left"/>
    <point x="-8.43413" y="-22.74231" z="10.54274" active="1" name="right"/>
</PickedPoints>
