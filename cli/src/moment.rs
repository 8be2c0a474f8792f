//! The requested moments of an animation.

use crate::args::ClockArgs;
use crate::failure::Failure;
use cosine_lobes::scene::Animation;

/// A moment of the animation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Moment {
    /// Its frame, where it is one of a sequence.
    pub(crate) frame: Option<u32>,
    /// Seconds.
    pub(crate) time: f32,
}

/// Number of the animation's last frame: the last one that is not after its end.
pub(crate) fn last_frame(animation: &Animation, fps: f32) -> u32 {
    // Allows for rounding below a whole number of frames.
    (f64::from(animation.duration()) * f64::from(fps) + 1e-3) as u32
}

fn at(frame: u32, fps: f32) -> f32 {
    (f64::from(frame) / f64::from(fps)) as f32
}

/// The one moment that is requested; the first one when none is.
pub(crate) fn single(args: ClockArgs, animation: &Animation) -> Result<Moment, Failure> {
    let fps = args.fps.unwrap_or(animation.fps());
    match (args.frame, args.time) {
        (Some(frame), _) => {
            if frame > last_frame(animation, fps) {
                return Err(Failure::new(format_args!("--frame {frame}: {}", frames(animation, fps))));
            }
            Ok(Moment { frame: None, time: at(frame, fps) })
        }
        (None, Some(time)) => {
            let end = animation.duration();
            if time > end {
                let all =
                    if animation.is_still() { STILL.to_owned() } else { format!("the animation ends at {end} s") };
                return Err(Failure::new(format_args!("--time {time}: {all}")));
            }
            Ok(Moment { frame: None, time })
        }
        (None, None) if args.fps.is_some() => Err(Failure::new("--fps: neither --frame nor --frames is given")),
        (None, None) => Ok(Moment::default()),
    }
}

/// The frames from the first to before the second.
pub(crate) fn sequence(args: ClockArgs, ends: (u32, u32), animation: &Animation) -> Result<Vec<Moment>, Failure> {
    let fps = args.fps.unwrap_or(animation.fps());
    if ends.1 - 1 > last_frame(animation, fps) {
        let all = frames(animation, fps);
        return Err(Failure::new(format_args!("--frames {}..{}: {all}", ends.0, ends.1)));
    }
    Ok((ends.0..ends.1).map(|frame| Moment { frame: Some(frame), time: at(frame, fps) }).collect())
}

/// The message for a scene without animation.
const STILL: &str = "nothing moves in this scene, so its first moment, frame 0, is all there is";

/// The frames of an animation, in words, and the option that renders all of them.
pub(crate) fn frames(animation: &Animation, fps: f32) -> String {
    if animation.is_still() {
        return STILL.to_owned();
    }
    let (last, seconds) = (last_frame(animation, fps), animation.duration());
    format!(
        "there are only frames 0 to {last} ({seconds} s at {fps} a second), all of them by --frames 0..{}",
        last + 1
    )
}
