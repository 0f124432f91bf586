//! Robot files and URDF as users meet them.
