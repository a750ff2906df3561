//! Reasons not to follow a link.

/// Why a link is not followed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// It names no scene.
    #[error("the link names no scene: it should read like #scene=cloth")]
    NoScene,
    /// It names a scene that is not there.
    #[error("the link names a scene that is not there: `{0}`")]
    UnknownScene(String),
    /// It was made by another version.
    #[error("the link was made by another version of msd: it has format {0}")]
    Format(u8),
    /// Some of it is missing, or is not what it was.
    #[error("the link is damaged: some of it is missing or was changed on its way")]
    Damaged,
    /// It is longer than a link may be, or what it holds unfolds to more.
    #[error("the link holds more than a link may hold")]
    TooLarge,
}
