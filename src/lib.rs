//! Elastic things as particles joined by springs and dampers.
