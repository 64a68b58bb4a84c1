"""A robot file: its joints' limits, the torques that hold it, and a pose by inverse kinematics."""
import math
import tempfile
from pathlib import Path

import kmech

URDF = """<robot name="arm"><link name="base"/>
 <link name="upper"><inertial><origin xyz="0.2 0 0"/><mass value="2"/><inertia ixx="0.01" iyy="0.03" izz="0.03" ixy="0" ixz="0" iyz="0"/></inertial></link>
 <link name="fore"><inertial><origin xyz="0.15 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
 <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="12" velocity="3"/></joint>
 <joint name="elbow" type="revolute"><origin xyz="0.4 0 0"/><parent link="upper"/><child link="fore"/><axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="6" velocity="3"/></joint>
</robot>"""

with tempfile.TemporaryDirectory() as folder:
    file = Path(folder) / "arm.urdf"
    file.write_text(URDF)
    model = kmech.load(file)

held = model.forces(here=True, actuators=["shoulder", "elbow"])
shoulder = held.table["f.shoulder"][0]
# By hand: 2 kg at 0.2 m and 1 kg at 0.55 m, about +y.
print(f"the shoulder holds {shoulder:.4f} N*m; by hand {-9.81 * (2 * 0.2 + 1 * 0.55):.4f} N*m")
assert math.isclose(shoulder, -9.81 * 0.95, rel_tol=1e-12)
print("limits:", {joint: model.limits(joint) for joint in ("shoulder", "elbow")})
