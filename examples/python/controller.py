"""A controller in Python: a motor with a speed controller drives a slider-crank, step by step."""
import pathlib

import kmech

models = pathlib.Path(__file__).resolve().parents[2] / "models"
model = kmech.load(models / "slider_crank.json")
session = kmech.Session(model, step=0.001, frames=["rod/origin"])

WANTED, GAIN, LAG = 6.0, 40.0, 0.2  # rad/s, N·m/(rad/s), s
integral, largest = 0.0, 0.0
for step in range(5000):
    error = WANTED - session.v("A")
    integral += 0.001 * error
    torque = GAIN * (error + integral / LAG)
    session.force("A", torque)
    session.step()
    if session.time > 4.0:
        largest = max(largest, abs(error))
print(f"after {session.time:.1f} s the crank turns at {session.v('A'):.3f} rad/s")
print(f"in the last second it differs from {WANTED} rad/s by at most {largest:.3f}")
print("the rod's joint is at", [round(float(x), 3) for x in session.frame("rod/origin").origin])
