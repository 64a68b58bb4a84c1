"""A four-bar linkage by calls: how its mobility numbers share one freedom, and where it toggles."""
import kmech

b = kmech.Builder(angle="degrees", length="millimeters")
b.body("crank").body("coupler").body("rocker")
b.frame("fixed", "D", T=[100, 0, 0])
b.frame("crank", "B", T=[40, 0, 0]).frame("coupler", "C", T=[95, 0, 0]).frame("rocker", "C", T=[70, 0, 0])
b.joint("A", "Rz", "fixed", "crank", position=60)
b.joint("B", "Rz", "crank/B", "coupler", position=-40)
b.joint("C", "Rz", "coupler/C", "rocker/C", position=80)
b.joint("D", "Rz", "fixed/D", "rocker", position=100)
model = b.finish()

answer = model.sweep("A", 0, 360, 180)
table = answer.table
total = sum(table[f"m.{joint}"] for joint in model.joints)
print(f"{len(table)} poses, the numbers add up to {total.min():.6f} … {total.max():.6f}")
value, where = answer.figure("m.D", "min")
print(f"the rocker moves least at {where:.1f} degrees of the crank: m.D = {value:.2g}")
