"""
A model as files of another program
===================================

An identified model can be written for Simulink, PythonVehicleSimulator, mmgdynamics or Gazebo. Here the derivative of
a response model is written as a MATLAB function, beside the record that the model explains.
"""

import tempfile

import helmbench

record = helmbench.simulate("response-1", "zigzag:20/20", noise="low", seed=1)
estimate = helmbench.identify(record, "nomoto-1-cubic", "output-error")
with tempfile.TemporaryDirectory() as folder:
    for path in helmbench.export_model(estimate.model, "simulink", folder):
        text = path.read_text(encoding="utf-8")
        print(f"==== {path.name}: {len(text.splitlines())} lines", *text.splitlines()[:6], sep="\n")

# %%
# The model that was written:

estimate.plot(record)
