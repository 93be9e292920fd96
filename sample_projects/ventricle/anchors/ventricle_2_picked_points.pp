<!DOCTYPE PickedPoints>
<PickedPoints>
    <point x="-0.16541" y="-34.06792" z="-14.68265" active="1" name="apex"/>
    <point x="15.57186" y="-13.66679" z="-5.04648" active="1" name="front"/>
    <point x="-7.44657" y="-6.94798" z="-18.82209" active="1" name="left"/>
    <point x="-10.38131" y="-20.77396" z="9.52537" active="1" name="right"/>
</PickedPoints>
