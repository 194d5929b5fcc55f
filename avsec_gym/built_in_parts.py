"""The kinds of parts that have names, and the parts that come with the package."""

from __future__ import annotations

from enum import StrEnum


class Kind(StrEnum):
    """What can be registered."""

    DETECTOR = "detector"
    ATTACK = "attack"
    CLASSIFIER = "classifier"
    SELECTOR = "selector"
    PLANNER = "planner"
    VALIDATOR = "validator"
    OPTICAL_ATTACK = "optical_attack"
    IMAGE_DETECTOR = "image_detector"
    DRIVE_ATTACK = "drive_attack"
    CONNECTED_ATTACK = "connected_attack"
    CONNECTED_VALIDATOR = "connected_validator"
    DEFENCE = "defence"

    @property
    def words(self) -> str:
        """The kind with its article, for a sentence: ``an optical attack``."""
        boxes = {"detector": "a detector of 3D boxes", "image_detector": "a detector of 2D boxes"}
        article = "an" if self[0] in "aeiou" else "a"
        return boxes.get(self, f"{article} {self.replace('_', ' ')}")


BUILT_IN = {
    (Kind.PLANNER, "astar"): ("avsec_gym.planners.planner:MotionPrimitivePlanner", {}),
    (Kind.PLANNER, "gbfs"): (
        "avsec_gym.planners.planner:MotionPrimitivePlanner",
        {"algorithm": "gbfs"},
    ),
    (Kind.DETECTOR, "dsgn"): (
        "avsec_gym.perception.detectors.dsgn.detector:DsgnDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "stereo_rcnn"): (
        "avsec_gym.perception.detectors.stereo_rcnn.detector:StereoRcnnDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "pixor"): (
        "avsec_gym.perception.detectors.pixor.detector:PixorDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "pointrcnn"): (
        "avsec_gym.perception.detectors.pointrcnn.detector:PointRcnnDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "scan_obstacles"): (
        "avsec_gym.perception.detectors.scan_obstacles:ScanObstacles",
        {},
    ),
    (Kind.IMAGE_DETECTOR, "faster_rcnn"): (
        "avsec_gym.perception.detectors.faster_rcnn.detector:FasterRcnnDetector",
        {"weights": "shipped"},
    ),
    (Kind.IMAGE_DETECTOR, "yolo"): (
        "avsec_gym.perception.detectors.yolo.detector:YoloDetector",
        {"weights": "shipped"},
    ),
    (Kind.DETECTOR, "single_image"): (
        "avsec_gym.perception.detectors.single_image:SingleImage",
        {},
    ),
    (Kind.DETECTOR, "attacked"): ("avsec_gym.attacks.attacked_detector:AttackedDetector", {}),
    (Kind.DETECTOR, "defended"): (
        "avsec_gym.perception.defences.defended_detector:defended_detector",
        {},
    ),
    (Kind.DETECTOR, "oracle"): ("avsec_gym.perception.detectors.recorded:Oracle", {}),
    (Kind.DETECTOR, "replayed"): ("avsec_gym.perception.detectors.recorded:Replayed", {}),
    (Kind.DEFENCE, "jpeg"): ("avsec_gym.perception.defences.jpeg:JpegCompression", {}),
    (Kind.DEFENCE, "bit_depth"): ("avsec_gym.perception.defences.bit_depth:BitDepth", {}),
    (Kind.DEFENCE, "median_filter"): (
        "avsec_gym.perception.defences.median_filter:MedianFilter",
        {},
    ),
    (Kind.DEFENCE, "gaussian_noise"): (
        "avsec_gym.perception.defences.gaussian_noise:GaussianNoise",
        {},
    ),
    (Kind.CLASSIFIER, "small"): (
        "avsec_gym.perception.motion.classifier:MovingObjectClassifier",
        {},
    ),
    (Kind.CLASSIFIER, "vgg16"): (
        "avsec_gym.perception.motion.classifier:vgg16_classifier",
        {},
    ),
    (Kind.SELECTOR, "small"): ("avsec_gym.perception.road_type:DrivingConstraintSelector", {}),
    (Kind.ATTACK, "thesis_pgd"): ("avsec_gym.attacks.perturbation:thesis_pgd", {}),
    (Kind.ATTACK, "fgsm"): ("avsec_gym.attacks.perturbation:fgsm", {}),
    (Kind.ATTACK, "i_fgsm"): ("avsec_gym.attacks.perturbation:i_fgsm", {}),
    (Kind.ATTACK, "mi_fgsm"): ("avsec_gym.attacks.perturbation:mi_fgsm", {}),
    (Kind.ATTACK, "projected_pgd"): ("avsec_gym.attacks.perturbation:projected_pgd", {}),
    (Kind.ATTACK, "expectation_over_noise"): (
        "avsec_gym.attacks.expectation_over_noise:ExpectationOverNoise",
        {},
    ),
    (Kind.ATTACK, "random_noise"): ("avsec_gym.attacks.noise:RandomNoise", {}),
    (Kind.ATTACK, "patch"): ("avsec_gym.attacks.patch:PatchAttack", {}),
    (Kind.ATTACK, "art"): ("avsec_gym.attacks.toolbox_attack:ToolboxAttack", {}),
    (Kind.ATTACK, "transferred"): ("avsec_gym.attacks.transferred:TransferredAttack", {}),
    (Kind.ATTACK, "strongest"): ("avsec_gym.attacks.strongest:StrongestAttack", {}),
    (Kind.VALIDATOR, "thresholds"): (
        "avsec_gym.validation.threshold_validator:ThresholdValidator",
        {},
    ),
    (Kind.VALIDATOR, "likelihood"): (
        "avsec_gym.validation.likelihood.likelihood_validator:LikelihoodValidator",
        {},
    ),
    (Kind.VALIDATOR, "connected"): (
        "avsec_gym.validation.connected.frame_validator:connected_validator",
        {},
    ),
    (Kind.OPTICAL_ATTACK, "facula"): ("avsec_gym.attacks.facula:Facula", {}),
    (Kind.OPTICAL_ATTACK, "lidar_spoofing"): ("avsec_gym.attacks.lidar_spoofing:LidarSpoofing", {}),
    (Kind.OPTICAL_ATTACK, "pasted_scan"): ("avsec_gym.attacks.pasted_scan:PastedScan", {}),
    (Kind.OPTICAL_ATTACK, "thesis"): ("avsec_gym.attacks.sensor_combination:thesis_attack", {}),
    (Kind.CONNECTED_ATTACK, "paste"): (
        "avsec_gym.validation.connected.attacks.pasted_object:PastedObject",
        {},
    ),
    (Kind.CONNECTED_ATTACK, "paste_in_path"): (
        "avsec_gym.validation.connected.attacks.pasted_object:PastedObject",
        {"where": "path", "name": "paste_in_path"},
    ),
    (Kind.CONNECTED_ATTACK, "paste_in_blind_spot"): (
        "avsec_gym.validation.connected.attacks.pasted_object:PastedObject",
        {"where": "blind_spot", "name": "paste_in_blind_spot"},
    ),
    (Kind.CONNECTED_ATTACK, "moving_ghost"): (
        "avsec_gym.validation.connected.attacks.moving_ghost:MovingGhost",
        {},
    ),
    (Kind.CONNECTED_ATTACK, "removal"): (
        "avsec_gym.validation.connected.attacks.removed_object:RemovedObject",
        {},
    ),
    (Kind.CONNECTED_VALIDATOR, "rays"): (
        "avsec_gym.validation.connected.named_validators:rays_validator",
        {},
    ),
    (Kind.CONNECTED_VALIDATOR, "surfaces"): (
        "avsec_gym.validation.connected.named_validators:surfaces_validator",
        {},
    ),
    (Kind.CONNECTED_VALIDATOR, "learned"): (
        "avsec_gym.validation.connected.named_validators:learned_validator",
        {},
    ),
    (Kind.DRIVE_ATTACK, "ghost"): ("avsec_gym.closed_loop.attack.lasting_ghosts:LastingGhosts", {}),
    (Kind.DRIVE_ATTACK, "facula"): (
        "avsec_gym.closed_loop.attack.tracking_facula:TrackingFacula",
        {},
    ),
    (Kind.DRIVE_ATTACK, "spoofed_scan"): (
        "avsec_gym.closed_loop.attack.spoofed_scan:SpoofedScan",
        {},
    ),
    (Kind.DRIVE_ATTACK, "patch"): ("avsec_gym.closed_loop.attack.lasting_patch:LastingPatch", {}),
}
"""Where each part is made, and with which arguments where none are given."""
NO_ATTACKS = {
    "pgd": "in version 0.2 no attack is named 'pgd', since the name changes its meaning: the"
    " thesis' form, whose sum of steps is not projected, is 'thesis_pgd'; the projected form of"
    " Madry et al. is 'projected_pgd', and 'pgd' from version 0.3 on",
    "random_ghosts": "'random_ghosts' is no attack on frames: it puts boxes into detections, as"
    " avsec_gym.attacks.object_injection.RandomGhosts; avsec/GhostObject-v1 is the same as a game",
}
"""Names that stand for no attack on frames, with the reason: those that change their meaning, and
what attacks something else."""
METHODS = {
    Kind.DETECTOR: "detect",
    Kind.ATTACK: "attack",
    Kind.CLASSIFIER: "classify",
    Kind.SELECTOR: "select",
    Kind.PLANNER: "plan",
    Kind.VALIDATOR: "validate",
    Kind.OPTICAL_ATTACK: "attack",
    Kind.IMAGE_DETECTOR: "detect",
    Kind.DRIVE_ATTACK: "act",
    Kind.CONNECTED_ATTACK: "attack",
    Kind.CONNECTED_VALIDATOR: "validate",
    Kind.DEFENCE: "defend",
}
"""What an object of each kind can do."""

ALL_PLANNERS = "all"
"""Asks for every planner of the package, where commands take several."""

RESERVED = {(Kind.PLANNER, ALL_PLANNERS)}
"""Names that commands take for something else: no part can have them."""
