//! The paper's filters.
