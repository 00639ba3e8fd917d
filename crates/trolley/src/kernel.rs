//! The kernel for anybody's triangles: trees, and which triangles of two bodies intersect.
