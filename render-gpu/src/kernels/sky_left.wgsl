// The lobes of each point that a sky leaves to its patches, behind the queue of one patch.

fn sky_left_place(point: u32) -> u32 { return frame.queue_stride * frame.point_count + point; }
