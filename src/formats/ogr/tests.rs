//! Files of other programs, and damaged ones.
