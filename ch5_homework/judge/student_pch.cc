// Carries the precompiled header of the students' files.
