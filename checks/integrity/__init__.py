"""What a file's samples show by themselves and of each other: time stamps, frozen samples, jumps, units, copies."""
