//! Laws of networks: what each impairment does to packets, recorded traces, the section of a study, and trials.

mod impairments;
mod passage;
mod random_numbers;
mod recorded;
mod section;
mod trials;
