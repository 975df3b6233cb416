; Grasp, lift, place, release: the manipulation domain of locotamp (docs/symbolic.md, "PDDL").
;
; The problem file is generated from a scene. What it tells (never changed by an action):
;   part-of    a surface belongs to a movable object
;   can-hold   a hand can hold the surface alone (a handle)
;   can-push   a hand can push on the surface
;   can-rest   the object's surface can be put down on the other surface
;   can-stick  the same, held in place by it (a peg, a magnet)
;   opposite   the two surfaces lie opposite, so that two hands can squeeze the object between them
;   elsewhere  the goal says nothing of the object: it may help to put it elsewhere, be it on the same surface
;
; holds, squeezes, rests and sticks stand for contacts; busy, gripped and down follow from them. moved is remembered of
; objects that may go elsewhere: a box put down a step further on the same floor is not where it was.

(define (domain manipulation)
  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions :equality
                 :existential-preconditions :universal-preconditions :conditional-effects)

  (:types hand surface movable - object)

  (:predicates
    (part-of ?s - surface ?o - movable)
    (can-hold ?h - hand ?s - surface)
    (can-push ?h - hand ?s - surface)
    (can-rest ?s ?t - surface)
    (can-stick ?s ?t - surface)
    (opposite ?s1 ?s2 - surface)
    (elsewhere ?o - movable)

    (holds ?h - hand ?s - surface)                  ; one hand holds a handle
    (squeezes ?h1 ?h2 - hand ?s1 ?s2 - surface)     ; two hands press on opposite surfaces
    (rests ?s ?t - surface)                         ; an object's surface lies on another
    (sticks ?s ?t - surface)                        ; the same, held by it

    (busy ?h - hand)                                ; the hand holds or squeezes something
    (gripped ?s - surface)                          ; a grasp is on the surface
    (down ?s - surface)                             ; the surface rests or sticks
    (moved ?o - movable))                           ; the object has left its place of the start

  ; One hand takes hold of a handle that is free and does not lie on anything.
  (:action grasp
    :parameters (?h - hand ?o - movable ?s - surface)
    :precondition (and
      (part-of ?s ?o) (can-hold ?h ?s)
      (not (busy ?h)) (not (gripped ?s)) (not (down ?s)))
    :effect (and (holds ?h ?s) (busy ?h) (gripped ?s)))

  ; Two hands take an object between them.
  (:action squeeze
    :parameters (?o - movable ?s1 ?s2 - surface ?h1 ?h2 - hand)
    :precondition (and
      (part-of ?s1 ?o) (opposite ?s1 ?s2)
      (can-push ?h1 ?s1) (can-push ?h2 ?s2) (not (= ?h1 ?h2))
      (not (busy ?h1)) (not (busy ?h2))
      (not (gripped ?s1)) (not (gripped ?s2)) (not (down ?s1)) (not (down ?s2)))
    :effect (and
      (squeezes ?h1 ?h2 ?s1 ?s2)
      (busy ?h1) (busy ?h2) (gripped ?s1) (gripped ?s2)))

  ; A held object leaves all its supports; what lies on it comes along.
  (:action lift
    :parameters (?o - movable)
    :precondition (and
      (exists (?s - surface) (and (part-of ?s ?o) (gripped ?s)))
      (exists (?s - surface) (and (part-of ?s ?o) (down ?s))))
    :effect (and
      (when (elsewhere ?o) (moved ?o))
      (forall (?s - surface) (when (part-of ?s ?o) (not (down ?s))))
      (forall (?s ?t - surface) (when (part-of ?s ?o) (and (not (rests ?s ?t)) (not (sticks ?s ?t)))))))

  ; A held object in the air comes to rest on a surface of the environment, or of an object that stands on something
  ; else than itself. Nothing is on the two surfaces face to face.
  (:action place
    :parameters (?o - movable ?s ?t - surface)
    :precondition (and
      (part-of ?s ?o) (can-rest ?s ?t)
      (exists (?x - surface) (and (part-of ?x ?o) (gripped ?x)))
      (forall (?x - surface) (not (and (part-of ?x ?o) (down ?x))))
      (not (gripped ?s)) (not (down ?t))
      (forall (?x - surface) (not (or (rests ?x ?s) (sticks ?x ?s))))
      (forall (?u - movable) (imply (part-of ?t ?u)
        (exists (?x ?y - surface)
          (and (part-of ?x ?u) (not (part-of ?y ?o)) (or (rests ?x ?y) (sticks ?x ?y)))))))
    :effect (and (rests ?s ?t) (down ?s)))

  ; The same onto a surface that holds the object.
  (:action attach
    :parameters (?o - movable ?s ?t - surface)
    :precondition (and
      (part-of ?s ?o) (can-stick ?s ?t)
      (exists (?x - surface) (and (part-of ?x ?o) (gripped ?x)))
      (forall (?x - surface) (not (and (part-of ?x ?o) (down ?x))))
      (not (gripped ?s)) (not (down ?t))
      (forall (?x - surface) (not (or (rests ?x ?s) (sticks ?x ?s))))
      (forall (?u - movable) (imply (part-of ?t ?u)
        (exists (?x ?y - surface)
          (and (part-of ?x ?u) (not (part-of ?y ?o)) (or (rests ?x ?y) (sticks ?x ?y)))))))
    :effect (and (sticks ?s ?t) (down ?s)))

  ; One hand lets go of an object that rests, or that another grasp holds.
  (:action release
    :parameters (?h - hand ?o - movable ?s - surface)
    :precondition (and
      (part-of ?s ?o) (holds ?h ?s)
      (exists (?x - surface) (and (part-of ?x ?o)
        (or (down ?x) (and (gripped ?x) (not (= ?x ?s)))))))
    :effect (and (not (holds ?h ?s)) (not (busy ?h)) (not (gripped ?s))))

  ; Two hands let go.
  (:action let-go
    :parameters (?o - movable ?s1 ?s2 - surface ?h1 ?h2 - hand)
    :precondition (and
      (part-of ?s1 ?o) (squeezes ?h1 ?h2 ?s1 ?s2)
      (exists (?x - surface) (and (part-of ?x ?o)
        (or (down ?x) (and (gripped ?x) (not (= ?x ?s1)) (not (= ?x ?s2)))))))
    :effect (and
      (not (squeezes ?h1 ?h2 ?s1 ?s2))
      (not (busy ?h1)) (not (busy ?h2)) (not (gripped ?s1)) (not (gripped ?s2)))))
