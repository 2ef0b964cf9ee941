//! eikona
