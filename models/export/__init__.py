"""Models as files of other programs: MATLAB and Simulink, PythonVehicleSimulator, mmgdynamics, Gazebo."""
