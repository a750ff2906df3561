//! Reasons to refuse a link.

/// Reason to refuse a link.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// The link has no scene.
    #[error("the link names no scene: it should read like #scene=cloth")]
    NoScene,
    /// The link names an unknown scene.
    #[error("the link names an unknown scene: `{0}`")]
    UnknownScene(String),
    /// The link has the format of another version.
    #[error("the link was made by another version of msd: it has format {0}")]
    Format(u8),
    /// A part of the link is missing or altered.
    #[error("the link is damaged: a part is missing or was changed")]
    Damaged,
    /// The link, or its content after decompression, exceeds the limit.
    #[error("the link is too large")]
    TooLarge,
}
