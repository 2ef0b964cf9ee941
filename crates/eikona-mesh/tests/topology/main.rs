//! Topology, orientation, validation, quality and repairs, on meshes with known results and on the
//! files of the data folder.

mod data_files;
mod faults_and_quality;
mod known_surfaces;
mod random_complexes;
mod renumbering;
mod repairs;
mod shapes;
mod stitching;
