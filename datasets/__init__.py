"""Records: the Record type, reading and writing, manoeuvres, sensors, disturbances, the generator, measured sets."""
